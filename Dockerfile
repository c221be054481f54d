# docker build -t lssd_learn . && docker run --rm -v "$PWD":/work -v lssd_cache:/cache lssd_learn --help
FROM python:3.12-slim
RUN pip install --no-cache-dir 'torch<2.14' --index-url https://download.pytorch.org/whl/cpu
COPY pyproject.toml README.md LICENSE /source/
COPY conf /source/conf
COPY lssd_learn /source/lssd_learn
RUN pip install --no-cache-dir '/source[bodies]' && rm -r /source
# The body model is built by the first run that needs it and kept with the cache.
ENV LSSD_CACHE=/cache/lssd_learn XDG_CACHE_HOME=/cache HOME=/cache MPLCONFIGDIR=/tmp
VOLUME /cache
WORKDIR /work
ENTRYPOINT ["lssd"]
