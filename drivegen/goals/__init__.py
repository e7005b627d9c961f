"""Where vehicles may be going: candidates along every way ahead, their features and odds, goals of a scene drawn together."""
