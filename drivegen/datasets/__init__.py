"""Data sets, one file each: a file here is found by its name (`ingest.source`) and covered by the contract test."""
