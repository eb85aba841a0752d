"""The artist's scene, character and Actions; besides operators/ and ui/ the only room that imports bpy."""
