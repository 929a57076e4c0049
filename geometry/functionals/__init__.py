"""What may be asked of a mesh, one file a wish."""
