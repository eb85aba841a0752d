"""The program: everything between an artist's scene and a finished Action. See docs/architecture.md."""
