"""The part of the sidebar and of the preferences that sends jobs to a render farm."""
