"""warp_mps: elastic structures by the Moving Particle Semi-implicit method (MPS), as NVIDIA Warp kernels."""

__version__ = "0.1.0"
