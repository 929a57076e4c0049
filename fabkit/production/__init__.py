"""From parts to shop documents, still as data: marks, nests, cut lists, drawings, the facts of a build."""
