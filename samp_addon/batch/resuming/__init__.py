"""What a second run over a jobs file skips, and the takes that it continues with."""
