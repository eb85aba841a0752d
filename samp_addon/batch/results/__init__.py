"""Views of a report: a page with pictures, and a table of all measures."""
