"""Controllers whose learned layer is a policy of another trainer: `sb3:model.zip`.

The other layers are hand-written: those of the controller in training. The code of the environments
makes the observations and reads the actions, so that a policy acts in an evaluation as in training.
It acts for one world at a time: the rounding of a matrix product depends on its number of rows, and
an episode must not depend on others that run with it.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import zip_longest
from typing import Any, Unpack

from baselines.controller import REGISTRIES, LayeredController
from baselines.controllers import SINGLE, SUBSUMPTION
from baselines.weighting.sgikf import SGIKF
from swarm_forage_env.controllers import find_controller, parse_controller
from swarm_forage_env.envs.config import PolicyKeywords
from swarm_forage_env.envs.keywords import Learn, PolicyOptions
from swarm_forage_env.envs.make import WITH_ARGUMENTS, observation_name
from swarm_forage_env.envs.pilot import Pilot
from swarm_forage_env.envs.policy_form import OF_BOUND, PolicyForm
from swarm_forage_env.errors import ConfigError, UnknownNameError
from swarm_forage_env.interface import Controller, RunningController, TeamController
from swarm_forage_env.parameters import BaseScenario, Parameters, validated
from swarm_forage_env.random_streams import NoiseSource
from swarm_forage_env.registry import CONTROLLERS, POLICIES
from swarm_forage_env.task import World, task_of
from training.policy import ForeignPolicy, FunctionPolicy, PolicyFile
from training.policy_card import PolicyCard, as_keywords
from training.running_policy import PolicyActor, RunningForeignPolicy


@dataclass(frozen=True)
class PolicyController(LayeredController):
    """Controller of a policy that replaces some or all layers; the others are hand-written, or one
    of them is another policy: `sb3:motion.zip,controller=sb3:weighting.zip`."""

    policy: ForeignPolicy
    beside: ForeignPolicy | None = None
    """Policy of another layer."""

    main_parameter = "file"
    """Parameter that follows the colon of a name: `sb3:model.zip`."""

    @property
    def layers(self) -> dict[str, Parameters]:
        """Parameters of each layer, and each policy."""
        return {**super().layers, **self.policies}

    @property
    def policies(self) -> dict[str, ForeignPolicy]:
        """The policy, and the one beside it."""
        beside = {} if self.beside is None else {"beside": self.beside}
        return {"policy": self.policy, **beside}

    @property
    def layer_names(self) -> dict[str, str]:
        """Name of each layer, and kind of each policy."""
        kinds = {name: type(policy).__name__ for name, policy in self.policies.items()}
        return {**self.hand_written.layer_names, **kinds}

    @property
    def is_everything(self) -> bool:
        """Whether the policy replaces all layers."""
        return self.policy.learn == "everything"

    @property
    def hand_written(self) -> LayeredController:
        """Controller of the hand-written layers alone."""
        return LayeredController(self.name, self.estimator, self.weighting, self.motion)

    def with_parameters(self, values: Mapping[str, Any]) -> "PolicyController":
        """Return the controller with some parameters changed, `file` and `controller` first.

        The card of the file gives the keywords and the controller of the training; `values`
        override them.
        """
        own, changed = dict(values), self
        file = own.pop("policy.file", own.pop("file", None))
        base_controller, beside = own.pop("controller", None), own.pop("beside", None)
        if file is not None:
            changed = self._with_policy({"file": file})
            card = changed.policy.card()
            if card is not None:
                _check_named(self.name, changed.policy, card, own)
                keywords = card.keywords.model_dump()
                changed = changed._with_policy({**changed.policy.model_dump(), **keywords})
                if beside is None:
                    base_controller = base_controller or changed._written_on(card)
        if beside is not None:  # its kind, as a dataset stores it with all layers
            kinds = {type(POLICIES[name].policy).__name__: POLICIES[name] for name in POLICIES}
            if beside not in kinds:
                raise UnknownNameError("kind of policy", str(beside), kinds)
            changed = replace(changed, beside=kinds[str(beside)].policy)
        if base_controller is not None:
            changed = changed._with_layers_of(base_controller)
        if changed.beside is not None:  # a bare name is the first policy's
            fields = type(changed.policy).model_fields
            own = {f"policy.{name}" if name in fields else name: own[name] for name in own}
        controller = super(PolicyController, changed).with_parameters(own)
        assert isinstance(controller, PolicyController)
        return controller._checked()

    def under(self, scenario: BaseScenario) -> TeamController:
        """Return the controller of the other layers; for a policy of everything, raw control."""
        raw_control = task_of(scenario).raw_control
        if self.is_everything and isinstance(raw_control, TeamController):
            return raw_control
        return self.hand_written

    def pilot(self, scenario: BaseScenario) -> Pilot:
        """Return the policy for compilation with the world. ConfigError if Python must call it."""
        form = self.form(scenario)
        if self.beside or self.policy.chance or form.additions or form.config.stack > 1:
            raise ConfigError(
                f"policy {self.policy.source}: runs in Python only, because it is stochastic,"
                " observes more than its layer does in a tick or runs beside another policy; leave"
                " out chance=true, or use one that observes its layer alone, without stack"
            )
        pilot = self.policy.pilot(form)
        if pilot.n_state and form.config.step_on == "exchange":
            raise ConfigError(
                f"policy {self.policy.source}: runs in Python only, because its memory advances at"
                " exchanges; use one that was trained with step_on='tick' or has no memory"
            )
        return pilot

    def language(self, scenario: Any) -> Any:  # noqa: ANN401 of any task
        """Return the language of the controller of the other layers."""
        return self.under(scenario).language(scenario)

    def over(
        self, world: World, inner: RunningController, robots: Sequence[int]
    ) -> RunningController:
        """Start the policies of some robots over the other layers. ConfigError if one does not
        fit."""
        sources = {"policy": NoiseSource.POLICY, "beside": NoiseSource.POLICY_BESIDE}
        for name, policy in self.policies.items():
            form = form_of(policy, world.scenario)
            actor = PolicyActor(policy, form, robots, sources[name])
            inner = RunningForeignPolicy(world, inner, form, actor, robots)
        return inner

    def check_usable(self, scenario: BaseScenario) -> None:
        """Raise ConfigError or UnknownNameError if a layer or a policy does not fit."""
        if not self.is_everything:
            self.hand_written.check_usable(scenario)
        for policy in self.policies.values():
            form = form_of(policy, scenario)
            PolicyActor(policy, form, range(len(form.agents)))

    def check_supports(self, scenario: BaseScenario) -> None:
        """Raise ConfigError if a hand-written layer does not support the world of this scenario."""
        if not self.is_everything:
            self.hand_written.check_supports(scenario)

    def assumed(self, scenario: BaseScenario) -> str:
        """Return a message on the keywords assumed for files without a card; empty with cards."""
        each = (self._assumed_of(name, scenario) for name in self.policies)
        return "; ".join(message for message in each if message)

    def _assumed_of(self, name: str, scenario: BaseScenario) -> str:
        policy = self.policies[name]
        if not isinstance(policy, PolicyFile) or policy.card() is not None:
            return ""
        form = form_of(policy, scenario)
        known = PolicyKeywords.model_fields
        terms = {keyword: value for keyword, value in form.config if keyword in known}
        if form.config.learn != "weighting":
            del terms["step_on"]
        terms["observation"] = policy.observation
        first = "wheels" if form.config.residual else next(iter(form.task.steerings), "none")
        terms["action"] = form.config.action or first
        terms["reflexes"] = form.action.has_reflexes
        if not self.is_everything:
            terms["controller"] = self.name_of_layers()
        prefix = "" if name == "policy" else f"{name}."
        return (
            f"policy {policy.source} has no card: assuming {as_keywords(terms)}; if it was"
            " trained with others, give them:"
            f" {self.name}:{self.policy.source},{prefix}decision_period=5"
        )

    def form(self, scenario: BaseScenario) -> PolicyForm:
        """Return the form of observations and actions. ConfigError if the card differs."""
        return form_of(self.policy, scenario)

    def _with_policy(self, terms: Mapping[str, object]) -> "PolicyController":
        return replace(self, policy=validated(type(self.policy), terms))

    def _written_on(self, card: PolicyCard) -> Controller | None:
        """Return the controller on a card; None for a policy of everything.

        ConfigError unless it consists of hand-written layers and parameters: a card opens no file.
        """
        if self.is_everything:
            return None
        try:
            bare = find_controller(card.controller.partition(":")[0])
            parts = bare.layers.values() if isinstance(bare, LayeredController) else ()
            if not parts or any(hasattr(type(part), "reads") for part in parts):
                raise ConfigError(f"controller '{card.controller}': must be of hand-written layers")
            parameters = parse_controller(card.controller)[1]
            if parameters.keys() & REGISTRIES.keys():
                raise ConfigError(f"controller '{card.controller}': must be a name and parameters")
            return bare.with_parameters(parameters)
        except (ConfigError, UnknownNameError) as error:
            raise ConfigError(
                f"policy {self.policy.source}: its card names no controller to run it beside"
                f" ({error}); name one, as in {self.name}:{self.policy.source},controller=ssgiff"
            ) from None

    def name_of_layers(self) -> str:
        """Return the name of the controller of the other layers, or else the layers' names."""
        layers = self.hand_written.layers
        alike = (
            each.name
            for each in CONTROLLERS.loaded()
            if isinstance(each, LayeredController) and each.layers == layers
        )
        return next(alike, "+".join(self.hand_written.layer_names.values()))

    def _with_layers_of(self, controller: str | Controller) -> "PolicyController":
        """Return this policy with the layers of another controller, or beside its policy.

        ConfigError if it has no layers or two policies.
        """
        other = find_controller(controller)
        if not isinstance(other, LayeredController):
            raise ConfigError(f"controller '{other.name}': must be made of layers")
        beside, *third = other.policies.values() if isinstance(other, PolicyController) else [None]
        if isinstance(beside, PolicyFile) and not beside.file:
            raise ConfigError(
                f"controller={other.name}: which file? Name it after the colon, as in"
                f" controller={other.name}:model.zip"
            )
        if third:
            raise ConfigError(
                f"policy {self.policy.source}: cannot run beside the two policies of"
                f" '{other.name}'; name one of them"
            )
        return PolicyController(
            self.name, other.estimator, other.weighting, other.motion, self.policy, beside
        )

    def _checked(self) -> "PolicyController":
        """Return this controller; ConfigError if its policies do not replace different layers."""
        if self.beside and {self.policy.learn, self.beside.learn} != {"motion", "weighting"}:
            raise ConfigError(
                f"policy {self.policy.source}: replaces {self.policy.learn}, and policy"
                f" {self.beside.source} beside it {self.beside.learn}; of two policies one must"
                " replace motion and the other weighting"
            )
        return self


def policy_controller(
    function: Callable[..., object],
    controller: str | Controller = "ssgikf",
    name: str = "policy",
    learn: Learn = "motion",
    n_state: int = 0,
    **keywords: Unpack[PolicyOptions],
) -> PolicyController:
    """Return a controller of a function that maps observations of a world's robots to actions.

        team = policy_controller(model.predict_rows, learn="motion", decision_period=5)
        env = parallel_env("es1", controller=team, learners=1)

    `learn` and `keywords` are those of `parallel_env` in training. With `n_state=64` the function
    also receives the hidden states of the robots, float32 (robots, 64), which are zero when an
    episode starts, and returns actions and the next states.

    Args:
        function: Maps observations (robots, features) to actions (robots, actions).
        controller: Controller of the layers that the policy does not replace.
        name: Name in tables and data.
        learn: Layers that the policy replaces.
        n_state: Size of the hidden state of a robot; 0: none.
        **keywords: Further keywords of `parallel_env` of the training.
    """
    terms = {"function": function, "learn": learn, "n_state": n_state, **keywords}
    policy = validated(FunctionPolicy, terms)
    return named_policy(name, policy)._with_layers_of(controller)._checked()


def named_policy(name: str, policy: ForeignPolicy) -> PolicyController:
    """Return a controller of a policy with the other layers of `ssgikf`."""
    return PolicyController(name, SINGLE, SGIKF(), SUBSUMPTION, policy)


def form_of(policy: ForeignPolicy, scenario: BaseScenario) -> PolicyForm:
    """Return the form of its observations and actions. ConfigError if the card differs."""
    form = PolicyForm([scenario], policy.config())
    card = policy.card()
    if card is not None:
        _check_observes(policy, card, form)
        if card.sizes:
            return PolicyForm([scenario], policy.config(), card.sizes)
    return form


def _check_named(
    name: str, policy: ForeignPolicy, card: PolicyCard, own: Mapping[str, object]
) -> None:
    """Raise ConfigError if only the card names an observation class, as a card runs no code, or if
    the class had arguments in training, which a name cannot give."""
    trained = card.keywords.observation
    named = own.get("observation", own.get("policy.observation"))
    for each in trained.split("+"):
        kind = each.removesuffix(WITH_ARGUMENTS)
        if kind != each and (named is None or kind in observation_name(named).split("+")):
            raise ConfigError(
                f"policy {policy.source}: observed by {each} in training, and {kind}() without"
                " these arguments observes something else; write a subclass that needs no"
                " arguments, and if you trust its module, name it, as in"
                f" {name}:{policy.source},observation=layer+module:Class"
            )
    if ":" in trained and named is None:
        raise ConfigError(
            f"policy {policy.source}: observes by a class of its trainer, which is imported only"
            " if it is named; if you trust its module, name it:"
            f" {name}:{policy.source},observation={trained}"
        )


def _check_observes(policy: ForeignPolicy, card: PolicyCard, form: PolicyForm) -> None:
    """Raise ConfigError for the first feature that was another one in training."""
    common = OF_BOUND if card.keywords.normalise == form.config.normalise else ""
    features = (
        [f"{name} [{unit.removeprefix(common)}]" for name, unit in side]
        for side in (card.observes, form.observes)
    )
    for k, (old, new) in enumerate(zip_longest(*features, fillvalue="nothing")):
        if old != new:
            raise ConfigError(
                f"policy {policy.source}: feature {k} of its observations was {old} in training"
                f" and is {new} here; use the scenario and the keywords of its training"
            )
    if card.sizes and len(card.sizes) != len(form.observed):
        raise ConfigError(
            f"policy {policy.source}: its card has the sizes of {len(card.sizes)} features, not of"
            f" {len(form.observed)}; write it with the keywords of its training"
        )
