"""The approximate shading model: arrays in, arrays out."""
