"""How anything is minimised. Knows arrays, and no mesh."""
