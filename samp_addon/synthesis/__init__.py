"""The methods: Goal and Path in, Motion out. No Blender here."""
