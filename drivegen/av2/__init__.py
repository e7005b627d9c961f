"""The official Argoverse 2 layout, in and out, as columns: no object per time step."""
