"""The tests that ship: `pytest --pyargs benchtool.acceptance --bench PROFILE --link URL`."""
