"""The methods that make motion, one folder each, behind one protocol; `registry.py` lists them."""
