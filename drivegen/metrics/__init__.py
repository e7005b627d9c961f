"""What is measured of traffic and of drivers, arrays in and numbers out; each file names where its measure comes from."""
