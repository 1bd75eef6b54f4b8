"""Verification: cases with closed forms, meshed by csgmesh, solved by MYSTRAN and CalculiX."""
