"""Read and prepare the motion capture clips."""
