# Every task of qRobot. `make` lists them.
# Needs git, make, python3 (3.11 to 3.13) and python3-venv; everything else comes from locks/.

PYTHON ?= python3
VENV ?= .venv
# What `make install` puts into the environment: base, solver, edge or full.
PROFILE ?= solver
# pytest's own options: two cores, and whoever is done takes tests from the other.
PYTEST_ARGS ?= -n 2 --dist worksteal
TEST_ARGS ?=
STACK_ARGS ?=
BENCH_ARGS ?=
# What `make image` builds: solver, edge or lab; for one or both machines; on trixie (3.13) or
# bookworm (3.11).
TARGET ?= edge
# What `make test-images` builds and tries.
IMAGES ?= solver edge lab
PLATFORM ?= linux/$(if $(filter aarch64 arm64,$(shell uname -m)),arm64,amd64)
RELEASE ?= trixie
UV_VERSION = 0.13.9

bin = $(VENV)/bin
# One stamp a profile tells that it is installed as the locks and pyproject.toml now are.
stamp = $(VENV)/.installed
project = pyproject.toml locks/build.txt
# No questions and no flood; what is fetched is held against the hashes of locks/.
pip = $(bin)/python -m pip --disable-pip-version-check --no-input --quiet
# What says more with the SDKs installed than without.
comma = ,
image-packages = buildah skopeo mmdebstrap arch-test debian-archive-keyring docker.io iptables qemu-user-static binfmt-support
stack-tests = tests/pages/test_blocks.py tests/gate tests/stacks tests/jobs tests/backends tests/study/test_reproduce.py tests/cli \
  tests/health/test_answers.py tests/health/test_notebooks.py tests/health/test_profiles.py
# Which robots: a folder or file; make virtual-pi says the one of the virtual Pi. LIMIT=robot is one of them.
INVENTORY ?= ansible/inventory
LIMIT ?=
# More for ansible-playbook: ANSIBLE_ARGS="--check --diff", "--ask-vault-pass", "-e qrobot_offline=true".
ANSIBLE_ARGS ?=
# What make wheelhouse collects for: solver, edge or lab.
WHEELHOUSE_PROFILE ?= edge
virtual-pi-packages = qemu-system-arm ipxe-qemu qemu-utils qemu-user-static binfmt-support mmdebstrap arch-test \
  debian-archive-keyring e2fsprogs dosfstools mtools openssh-client iproute2
# It says with which exit code a playbook ended: make itself ends with 2 in any case.
play = $(bin)/python ansible/controller/play.py
robots = --inventory '$(INVENTORY)' $(if $(LIMIT),--limit '$(LIMIT)') $(ANSIBLE_ARGS)
shell-scripts = docker/*.sh ansible/virtual-pi/*.sh locks/*.sh tests/ansible/*.sh
source = qrobot tests ansible benchmarks docker docs/hooks examples healthchecks locks

.DEFAULT_GOAL := help
.DELETE_ON_ERROR:
.NOTPARALLEL:
.PHONY: help setup install demo test test-slow test-stacks test-roles provision upgrade rollback fleet-health drift credentials reset wheelhouse virtual-pi virtual-pi-tools virtual-pi-ssh virtual-pi-stop virtual-pi-reset test-virtual-pi test-images test-arm64 image image-tools notebooks tutorial lint format docs bench lock lock-upgrade lock-verify dist clean distclean

help: ## list the targets
	@echo 'qRobot: orders in, a checked picking plan out.'
	@awk -F ':.*## |^##@ ' '/^##@ / { print "\n" $$2 } /^[a-z0-9-]+:.*## / { printf "  make %-16s %s\n", $$1, $$2 }' $(firstword $(MAKEFILE_LIST))
	@echo
	@echo '  Variables: PYTHON=$(PYTHON)  VENV=$(VENV)  PROFILE=$(PROFILE)  PYTEST_ARGS="$(PYTEST_ARGS)"'

##@ Plan

install: $(stamp)-$(PROFILE) ## make .venv for use: PROFILE=base, solver (default), edge or full
	@echo "$(VENV) is ready: $(PROFILE)"

demo: $(stamp)-solver ## plan the example warehouse: a plan and its picture in build/demo
	@mkdir -p build/demo
	$(bin)/qrobot solve examples/small-warehouse.json --deadline 5 \
	  --output build/demo/plan.json --picture build/demo/plan.svg --picture build/demo/plan.png
	@echo
	@echo 'The plan:    $(CURDIR)/build/demo/plan.json'
	@echo 'The picture: $(CURDIR)/build/demo/plan.svg (the same as plan.png)'

tutorial: $(stamp)-dev $(stamp)-edge ## run the tutorial as a notebook: build/tutorial.ipynb and .html
	@mkdir -p build
	$(bin)/python examples/run_tutorial.py build/tutorial.ipynb

##@ Develop

setup: $(stamp)-dev ## make .venv for development: solver, tests, checks, docs, provisioning
	@echo "$(VENV) is ready for development"

test: $(stamp)-dev ## run the tests but for the slow ones (PYTEST_ARGS="-k name")
	$(bin)/python -m pytest -m 'not slow' $(PYTEST_ARGS) $(TEST_ARGS)

test-slow: $(stamp)-dev ## run the slow tests: whole pages and playbooks, long searches
	$(bin)/python -m pytest -m slow $(PYTEST_ARGS) $(TEST_ARGS)

test-stacks: $(stamp)-dev $(stamp)-edge ## run the tests of the quantum stacks too: installs the profile edge (1.5 GB)
	$(bin)/python -m pytest $(PYTEST_ARGS) $(stack-tests) $(STACK_ARGS)

notebooks: $(stamp)-dev $(stamp)-edge ## run the health checks as notebooks, copies in build/health
	$(bin)/qrobot health --notebooks build/health

lint: $(stamp)-dev ## check the style, the types and the locks
	$(bin)/ruff check $(wildcard $(source))
	$(bin)/ruff format --check $(wildcard $(source))
	$(bin)/mypy
	$(bin)/python -m locks.verify
	$(bin)/python ansible/controller/check_roles.py
	cd ansible && ../$(bin)/yamllint --strict . && PATH="$(abspath $(bin)):$$PATH" ../$(bin)/ansible-lint -q --nocolor
	@if command -v shellcheck >/dev/null; then shellcheck $(shell-scripts); else echo 'no shellcheck here: shell scripts are not checked'; fi

format: $(stamp)-dev ## put the code into the house style
	$(bin)/ruff check --fix-only --quiet $(wildcard $(source))
	$(bin)/ruff format $(wildcard $(source))

docs: $(stamp)-dev ## build the site into build/site (QROBOT_DOCS_EXECUTE=false: notebooks without outputs)
	NO_MKDOCS_2_WARNING=1 $(bin)/mkdocs build --strict --quiet
	@echo 'The site: $(CURDIR)/build/site/index.html'

bench: $(stamp)-dev ## measure on this machine and write docs/benchmarks.md anew
	$(bin)/python -m benchmarks.run $(BENCH_ARGS)

dist: $(stamp)-dev ## build the wheel and the source archive into build/dist
	$(bin)/python -m hatchling build --clean --target wheel --target sdist --directory build/dist

lock: .venv-lock/bin/uv ## make the locks anew after a change of pyproject.toml, versions kept
	locks/compile.sh $<

lock-upgrade: .venv-lock/bin/uv ## make the locks anew with the newest versions allowed
	locks/compile.sh $< --upgrade

lock-verify: .venv-lock/bin/uv $(stamp)-dev ## install every lock for every platform into a scratch folder, print sizes
	$(bin)/python -m locks.verify --install $<

clean: ## remove what was built; keep the environments
	rm -rf build .pytest_cache .mypy_cache .ruff_cache .hypothesis
	find $(wildcard $(source)) -name __pycache__ -type d -prune -exec rm -rf {} +

distclean: clean ## remove the environments too
	rm -rf .venv .venv-*

##@ Robots

provision: $(stamp)-provision ## from a bare Pi to a healthy robot: INVENTORY=, LIMIT=, ANSIBLE_ARGS="--check --diff"
	$(play) provision $(robots)

upgrade: $(stamp)-provision ## bring this checkout's version to the robots, one first, each proven before it counts
	$(play) upgrade $(robots)

rollback: $(stamp)-provision ## return to the release before
	$(play) rollback $(robots)

fleet-health: $(stamp)-provision ## run the health checks on all robots: build/fleet/fleet.html
	$(play) health $(robots)

drift: $(stamp)-provision ## what robots have against the locks and each other: build/fleet/drift.html
	$(play) drift $(robots)

credentials: $(stamp)-provision ## ask for the clouds' tokens and put them on the robots
	$(play) credentials $(robots)

reset: $(stamp)-provision ## take qRobot off a robot: LIMIT=robot ANSIBLE_ARGS="-e reset_confirm=robot"
	$(play) reset $(robots)

wheelhouse: $(stamp)-provision ## collect a robot's wheels beforehand, for Python 3.11 and 3.13: WHEELHOUSE_PROFILE=edge
	@for python in 3.11 3.13; do \
	  $(bin)/python ansible/controller/wheelhouse.py --profile $(WHEELHOUSE_PROFILE) --python $$python --strict || exit; \
	done

test-roles: $(stamp)-dev ## run the playbooks on a Debian of this machine's kind that boots in a namespace (root)
	QROBOT_ROLES=1 $(bin)/python -m pytest -n 2 --dist loadfile tests/ansible/test_roles.py tests/ansible/test_roles_change.py \
	  tests/ansible/test_roles_ssh.py tests/ansible/test_roles_lost.py tests/ansible/test_roles_pi.py \
	  tests/ansible/test_roles_recipe.py tests/ansible/test_fleet_machine.py tests/ansible/test_roles_lab.py

##@ A virtual Pi

virtual-pi-tools: ## install what runs the virtual Pi (root, Debian): qemu-system-arm, qemu-utils, mmdebstrap, mtools
	apt-get update --quiet=2
	apt-get install --yes --quiet=2 --no-install-recommends $(virtual-pi-packages)

virtual-pi: $(stamp)-provision ## boot a virtual Pi (its disk is built once by root, 15 minutes: ansible/virtual-pi/build.sh)
	ansible/virtual-pi/virtual-pi.sh start

virtual-pi-ssh: ## log into the virtual Pi
	@ansible/virtual-pi/virtual-pi.sh ssh

virtual-pi-stop: ## shut the virtual Pi down
	ansible/virtual-pi/virtual-pi.sh stop

virtual-pi-reset: ## throw the virtual Pi's disk away: the next start is a first boot
	ansible/virtual-pi/virtual-pi.sh reset

test-virtual-pi: $(stamp)-provision ## prove the playbooks on the virtual Pi (hours): STEPS="bare provision again"
	$(pip) install --require-hashes --requirement locks/build.txt
	PYTHONPATH=tests $(bin)/python -m virtual_pi.prove $(STEPS)

##@ Images

image-tools: ## install what builds and runs images here (root, Debian): buildah, skopeo, mmdebstrap, docker.io, qemu-user-static
	apt-get update --quiet=2
	apt-get install --yes --quiet=2 --no-install-recommends $(image-packages)

image: ## build an image: TARGET=solver, edge or lab, PLATFORM=linux/arm64,linux/amd64, RELEASE=trixie or bookworm
	docker/image.sh $(TARGET) $(PLATFORM) $(RELEASE)
	@if docker info >/dev/null 2>&1; then \
	  docker/load.sh $(patsubst linux/%,qrobot:$(TARGET)-$(RELEASE)-%,$(subst $(comma), ,$(PLATFORM))); \
	else \
	  echo 'No Docker engine answers: the image stays with buildah'; \
	fi

test-images: $(stamp)-dev ## build the images for this machine and hold them to what docs/images.md says
	@set -eu; \
	if [ "$$(docker/engine.sh start)" = started ]; then trap 'docker/engine.sh stop' EXIT; fi; \
	for target in $(IMAGES); do docker/image.sh $$target $(PLATFORM) $(RELEASE); done; \
	QROBOT_IMAGES=$(RELEASE) QROBOT_TARGETS='$(IMAGES)' $(bin)/python -m pytest tests/images

test-arm64: ## prove the arm64 images on an emulated Cortex-A72: reports in build/arm64
	docker/test-arm64.sh

# --- environments ---------------------------------------------------------------------------------

.venv-lock/bin/uv: Makefile
	@echo 'Installing uv $(UV_VERSION) into .venv-lock'
	@rm -rf .venv-lock
	@$(PYTHON) -m venv .venv-lock
	@.venv-lock/bin/python -m pip --disable-pip-version-check --no-input --quiet install uv==$(UV_VERSION)
	@touch $@

# While an environment is being made a file in it says so: an interrupted one is begun again.
# The build tools come first, so that building the project (and the two packages that exist as
# source only) fetches nothing unhashed.
$(stamp)-%: locks/%.txt $(project)
	@$(PYTHON) -c 'import sys; sys.exit(not (3, 11) <= sys.version_info < (3, 14))' || \
	  { echo 'qRobot needs Python 3.11, 3.12 or 3.13: make PYTHON=/path/to/python3.13 ...' >&2; exit 1; }
	@if [ -e $(VENV)/.unfinished ] || [ ! -e $(VENV)/.made ]; then $(make-venv); fi
	@touch $(VENV)/.unfinished
	@echo "Installing $$(grep -c '==' $<) packages of $< (a minute or two on a first run)"
	@$(pip) install --require-hashes --requirement locks/build.txt
	@$(pip) install --require-hashes --no-build-isolation --requirement $<
	@echo 'Installing qRobot itself'
	@$(pip) install --no-deps --no-build-isolation --editable .
	@$(if $(filter solver dev edge full,$*),echo 'Compiling the searches for this machine' && $(bin)/qrobot compile)
	@rm $(VENV)/.unfinished
	@touch $@ $(if $(filter dev edge full,$*),$(stamp)-solver) $(if $(filter dev,$*),$(stamp)-provision) $(if $(filter full,$*),$(stamp)-edge)

define make-venv
  if [ -n "$$(ls -A $(VENV) 2>/dev/null)" ] && [ ! -e $(VENV)/.unfinished ] && [ ! -e $(VENV)/pyvenv.cfg ]; then \
    echo '$(VENV) is there and is no environment: it is left alone, give another VENV=' >&2; exit 1; \
  fi; \
  echo "Making $(VENV) with $$($(PYTHON) --version)"; \
  rm -rf $(VENV) && mkdir -p $(VENV) && touch $(VENV)/.unfinished && \
  $(PYTHON) -m venv $(VENV) && touch $(VENV)/.made || exit 1
endef
