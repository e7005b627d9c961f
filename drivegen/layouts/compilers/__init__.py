"""One file per family of roads: a typed specification in, nodes, edges and connections of a plain network out.

All of them draw right-hand traffic; `compile.py` mirrors the result where traffic keeps left.
"""
