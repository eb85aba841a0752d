"""The measures of the papers."""
