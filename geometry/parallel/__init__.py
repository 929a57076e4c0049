"""Mesh parallelism [Pottmann2007, 2 to 4]: parallel meshes, Gauss images, offsets, support structures."""
