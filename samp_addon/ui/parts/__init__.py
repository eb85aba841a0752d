"""Parts that panels draw: buttons of long work, the line that says what to do next."""
