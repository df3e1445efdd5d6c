!> What the operator of a simulated satellite goes by, and where that is wrong.
module gracecg_simulation_operator_errors
    implicit none
    private
    public :: operator_t

    !> The operator of a case.
    type :: operator_t
        integer :: head = 1     !! Star-camera head whose quaternions are used
    end type operator_t
end module gracecg_simulation_operator_errors
