"""The analyst's judgement: rule bases as YAML, and the engine that turns facts into conclusions."""
