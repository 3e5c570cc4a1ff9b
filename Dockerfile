# The wheels in dist (`make wheel`) in a small Debian: docker build -t stiction . && docker run --rm -v "$PWD:/data" stiction plan planar_hand -o out
FROM debian:trixie-slim
RUN apt-get update && apt-get install -y --no-install-recommends ca-certificates python3-venv && rm -rf /var/lib/apt/lists/*
COPY dist/*.whl /wheels/
RUN python3 -m venv /opt/stiction && /opt/stiction/bin/pip install --no-cache-dir --find-links /wheels stiction && rm -rf /wheels
ENV PATH=/opt/stiction/bin:$PATH XDG_CACHE_HOME=/var/tmp
WORKDIR /data
ENTRYPOINT ["stiction"]
