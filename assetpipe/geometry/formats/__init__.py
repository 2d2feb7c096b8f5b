"""Mesh file formats: each module turns the bytes of one format into a :class:`RawMesh`.

Every reader is bounded by :class:`FileLimits`, says file and line where it can, never
follows a reference out of the file's own folder and drops nothing silently. Lengths and
axes are as in the file; :mod:`assetpipe.geometry.units` turns them into metres, Z-up.
"""
