"""The evaluation metrics of the papers."""
