"""From recordings to scenarios: which recordings are admitted, to which split they go, which vehicles are taken."""
