"""What must hold of placed parts, seen from their solids only: fit, clashes, panels in their cells."""
