"""The numbers that the paper prints (DriveGen, arXiv 2503.05808, tables I to IV), all on Argoverse 2."""

MARK = "paper, on Argoverse 2"

QUALITY: dict[str, tuple[float, float, float, float, float]] = {
    "SceneTransformer": (1.50, 3.12, 2.92, 3.89, 0.61),
    "BITS": (1.24, 2.87, 1.92, 3.42, 0.57),
    "TrafficGen": (3.23, 5.26, 5.21, 8.89, 0.75),
    "LCTGen": (1.89, 2.64, 2.78, 4.10, 0.76),
    "DriveGen w/o gs": (2.34, 3.62, 4.15, 6.21, 1.20),
    "DriveGen": (1.18, 2.16, 2.59, 3.64, 0.93),
}
"""Table I: min-sADE, min-sFDE, mean-sADE, mean-sFDE [m], diversity ratio."""

Driving = tuple[str, str, str, str]
"""Collision rate, driven distance [m], comfort, diversity, as printed."""

DOWNSTREAM: dict[str, tuple[Driving, Driving]] = {
    "Dataset": (("0.15", "55.67", "4.59", "8.67"), ("0.18", "48.27", "1.49", "5.32")),
    "SceneTransformer": (("0.16", "52.45", "5.26", "7.49"), ("0.19", "42.72", "1.21", "3.85")),
    "BITS": (("0.15", "56.90", "5.10", "7.84"), ("0.21", "49.36", "1.75", "3.07")),
    "TrafficGen": (("0.14", "58.30", "4.95", "8.29"), ("0.20", "52.25", "2.10", "5.35")),
    "LCTGen": (("0.13", "60.31", "5.31", "8.75"), ("0.18", "51.77", "2.58", "6.01")),
    "DriveGen w/o m": (("0.13", "61.32", "5.56", "9.10"), ("0.17", "51.89", "2.24", "6.53")),
    "DriveGen w/o gs": (("0.15", "55.90", "5.21", "8.65"), ("0.20", "51.37", "2.34", "5.78")),
    "DriveGen": (("0.12", "64.73", "6.25", "10.09"), ("0.15", "55.89", "3.70", "7.77")),
}
"""Table II: drivers finetuned on each method's scenarios, GAIL and SAC."""

CORNER: dict[str, tuple[Driving, Driving, Driving]] = {
    "Dataset": (("0.07", "49.04", "0.325", "15.76"), ("0.15", "55.67", "4.59", "8.67"), ("0.18", "48.27", "1.49", "5.32")),
    "AdvSim": (("0.11", "41.60", "0.330", "14.25"), ("0.23", "35.41", "3.85", "5.01"), ("0.37", "26.64", "1.72", "5.14")),
    "DiffScene": (("0.14", "44.86", "0.303", "15.75"), ("0.26", "38.27", "4.72", "5.53"), ("0.41", "27.56", "1.51", "4.39")),
    "DriveGen-CS": (("0.25", "39.50", "0.246", "4.43"), ("0.28", "34.72", "2.51", "6.40"), ("0.39", "25.53", "1.13", "3.62")),
}
"""Table III: drivers met by corner cases, IDM, GAIL and SAC."""

GPU_HOURS: dict[str, tuple[str, str]] = {
    "AdvSim": ("4.2", "0.35"),
    "DiffScene": ("5.7", "0.89"),
    "DriveGen-CS": ("0", "0.75"),
}
"""Table IV: GPU hours for 1000 corner cases: finetuning, generation."""
