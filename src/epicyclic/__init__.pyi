"""Names of the package, one a line: `__init__.py` reads these lines and imports a name when it is first used."""

from .audits.audit import audit as audit
from .errors import ConvergenceError as ConvergenceError
from .errors import ModelError as ModelError
from .questions.check.verbs import check as check
from .questions.check.verbs import matrices as matrices
from .questions.flanks.verbs import contact as contact
from .questions.flanks.verbs import efficiency as efficiency
from .questions.flanks.verbs import relief as relief
from .questions.flanks.verbs import stiffness as stiffness
from .questions.modes.verbs import campbell as campbell
from .questions.modes.verbs import modes as modes
from .questions.modulation.verbs import modulation as modulation
from .questions.response.verbs import steady as steady
from .questions.response.verbs import sweep as sweep
from .questions.sharing.verbs import sharing as sharing
from .questions.stability.verbs import stability as stability
from .questions.studies.compare import compare as compare
from .questions.studies.parameter_studies import vary as vary
from .questions.studies.verbs import sensitivity as sensitivity
from .questions.studies.verbs import study as study
from .questions.studies.verbs import track as track
from .questions.tolerance.verbs import allocate as allocate
from .questions.tolerance.verbs import tolerance as tolerance
from .questions.transient.verbs import transient as transient
from .results.dataset import load_result as load_result
from .results.dataset import save_result as save_result
from .results.dataset import to_json as to_json
from .results.files import save_matrices as save_matrices
from .rexs.export import write_rexs as write_rexs
from .rexs.import_train import read_rexs as read_rexs
from .show.plot import figure_names as figure_names
from .show.plot import plot as plot
from .show.report import write_report as write_report
from .statics.verbs import static as static
from .system.assembly import assemble as assemble
from .system.system import System as System
from .terms import explain as explain
from .train.new_train import differential as differential
from .train.new_train import planetary as planetary
from .train.new_train import star as star
from .train.resolution import load as load
from .train.train import Train as Train

__all__: list[str]
__version__: str
