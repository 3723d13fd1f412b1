"""The ground program compiled to a circuit (d-DNNF)."""
