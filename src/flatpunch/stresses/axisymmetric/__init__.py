"""Fields of axisymmetric loads: waves, rings and discs, through the layers and in power-law half-spaces."""
