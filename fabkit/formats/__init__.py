"""The only room that knows formats and kernels, a file each."""
