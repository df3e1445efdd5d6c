program gracecg_main
    implicit none
end program gracecg_main
