!> What the operator of a simulated satellite goes by, and where that is wrong.
module gracecg_simulation_operator_errors
    use gracecg_observations_knowledge, only: a_priori_t
    implicit none
    private
    public :: operator_t

    !> The operator of a case.
    type :: operator_t
        integer :: head = 1     !! Star-camera head whose quaternions are used
        type(a_priori_t) :: a_priori    !! How well it is believed to be known
    end type operator_t
end module gracecg_simulation_operator_errors
