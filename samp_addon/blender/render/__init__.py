"""Pictures of takes: Workbench renders, contact sheets and short films."""
