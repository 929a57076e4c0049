"""The page that shows a build: model, tables, figures, sheets."""
