# swarm-forage with all that evaluates, draws and trains on a CPU, as constraints.txt pins it.
#
#     docker build -t swarm-forage .
#     docker run --rm -v "$PWD/runs:/work/runs" swarm-forage evaluate es1 ssgikf learned-both

FROM python:3.11-slim

WORKDIR /opt/swarm-forage
COPY pyproject.toml constraints.txt README.md LICENSE ./
COPY swarm_forage_env swarm_forage_env
COPY baselines baselines
COPY training training
RUN python -m pip install --no-cache-dir --constraint constraints.txt \
    --extra-index-url https://download.pytorch.org/whl/cpu '.[train,render,play]'
WORKDIR /work
ENTRYPOINT ["swarm-forage"]
CMD ["--help"]
