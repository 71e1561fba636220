"""BibTeX of the works that optimizers in several modules come from."""

HANSEN = """
    @article{hansen2001,
      author = {Hansen, Nikolaus and Ostermeier, Andreas},
      title = {Completely Derandomized Self-Adaptation in Evolution Strategies},
      journal = {Evolutionary Computation},
      volume = {9},
      number = {2},
      pages = {159--195},
      year = {2001},
      doi = {10.1162/106365601750190398},
    }
"""

JONES = """
    @article{jones1993,
      author = {Jones, D. R. and Perttunen, C. D. and Stuckman, B. E.},
      title = {{Lipschitzian} optimization without the {Lipschitz} constant},
      journal = {Journal of Optimization Theory and Applications},
      volume = {79},
      pages = {157--181},
      year = {1993},
      doi = {10.1007/BF00941892},
    }
"""

STORN = """
    @article{storn1997,
      author = {Storn, Rainer and Price, Kenneth},
      title = {Differential Evolution -- A Simple and Efficient Heuristic for Global Optimization over Continuous
        Spaces},
      journal = {Journal of Global Optimization},
      volume = {11},
      number = {4},
      pages = {341--359},
      year = {1997},
      doi = {10.1023/A:1008202821328},
    }
"""
