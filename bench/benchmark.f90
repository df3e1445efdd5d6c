program benchmark
    implicit none
end program benchmark
