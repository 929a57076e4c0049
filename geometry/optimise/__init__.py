"""How anything is minimised: arrays, no meshes."""
