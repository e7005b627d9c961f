"""CommonRoad files, read only: versions 2018b and 2020a as their public format documentation describes them."""
