"""Protocols, metrics, weight rules and rival methods: what is measured and how."""
