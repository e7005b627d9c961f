"""Descriptions of roads with what they must become or why they must be refused, and how a writer fares with them."""
