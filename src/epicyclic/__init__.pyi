"""Names of the package, one a line: `__init__.py` reads these lines and imports a name when it is first used."""

from .audits.audit import audit as audit
from .errors import ConvergenceError as ConvergenceError
from .errors import ModelError as ModelError
from .questions.parameters.parameter_studies import vary as vary
from .results.dataset import load_result as load_result
from .results.dataset import save_result as save_result
from .results.dataset import to_json as to_json
from .results.files import save_matrices as save_matrices
from .rexs.import_train import read_rexs as read_rexs
from .rexs_export.export import write_rexs as write_rexs
from .show.plot import figure_names as figure_names
from .show.plot import plot as plot
from .show.report import write_report as write_report
from .system.assembly import assemble as assemble
from .system.system import System as System
from .terms.explain import explain as explain
from .train.new_train import differential as differential
from .train.new_train import planetary as planetary
from .train.new_train import star as star
from .train.resolution import load as load
from .train.train import Train as Train
from .verbs.allocate import allocate as allocate
from .verbs.campbell import campbell as campbell
from .verbs.check import check as check
from .verbs.compare import compare as compare
from .verbs.contact import contact as contact
from .verbs.efficiency import efficiency as efficiency
from .verbs.matrices import matrices as matrices
from .verbs.modes import modes as modes
from .verbs.modulation import modulation as modulation
from .verbs.relief import relief as relief
from .verbs.sensitivity import sensitivity as sensitivity
from .verbs.sharing import sharing as sharing
from .verbs.stability import stability as stability
from .verbs.static import static as static
from .verbs.steady import steady as steady
from .verbs.stiffness import stiffness as stiffness
from .verbs.study import study as study
from .verbs.sweep import sweep as sweep
from .verbs.tolerance import tolerance as tolerance
from .verbs.track import track as track
from .verbs.train_contact import train_contact as train_contact
from .verbs.transient import transient as transient

__all__: list[str]
__version__: str
