"""Goal selectors, one file each: they rank a vehicle's candidate goals and give them probabilities."""
