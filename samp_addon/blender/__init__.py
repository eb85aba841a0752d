"""The only place besides operators/ and ui/ that imports bpy."""
