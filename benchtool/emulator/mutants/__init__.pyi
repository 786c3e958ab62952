from .mutant import Mutant as Mutant
from .table import MUTANTS as MUTANTS
