# The command and the Python package in a small image, by the wheel:
#   ./dev wheel && docker build -t palpate . && docker run --rm -v "$PWD:/work" palpate run scene.json
# Of the wheels in dist/, pip takes that of the machine. The test Install.docker runs these steps in a clean root, without docker.
FROM debian:12-slim
RUN apt-get update && apt-get install -y --no-install-recommends python3 python3-venv ca-certificates && rm -rf /var/lib/apt/lists/*
COPY dist/palpate-*-cp311-*.whl /tmp/
RUN python3 -m venv /opt/palpate && /opt/palpate/bin/pip install --no-cache-dir /tmp/palpate-*_$(uname -m).whl && rm /tmp/palpate-*.whl
ENV PATH=/opt/palpate/bin:/usr/bin:/bin
WORKDIR /work
ENTRYPOINT ["palpate"]
CMD ["--help"]
