"""One image or many: perceive, the document, batch, BOP."""
