"""The published tables: rows of figures out of several runs, tables out of rows, and the folder that holds them."""
