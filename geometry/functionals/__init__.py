"""What may be asked of a mesh, one file a wish: planarity, parallelity, fairness, nearness to the sphere."""
