"""Edge offset meshes [Pottmann2007, 3.2, 3.3]: circle patterns and Koebe polyhedra, the geometry that moves them."""
