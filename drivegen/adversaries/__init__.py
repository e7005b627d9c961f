"""Who looks for what makes a driver fail: DriveGen-CS and its rivals, one file each, same scenes, at most as many runs."""
