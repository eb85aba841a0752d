"""Takes in a .blend file: bake, measure, report, list and export them."""
