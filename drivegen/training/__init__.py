"""What every training shares: the loop, checkpoints, curves, clocks, and weights as safetensors."""
